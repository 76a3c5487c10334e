import pytest

from pam_ident.core.progress import Stage, Stopped, heard, part, steps, tell


def test_without_a_listener_nothing_happens():
    tell("alone")
    assert list(steps([1, 2], "alone")) == [1, 2]


def test_a_listener_hears_stages_counts_and_parts_and_no_more_afterwards():
    said = []
    with heard(said.append):
        tell("reading")
        with part("rung 1"):
            assert list(steps((c for c in "ab"), "weighing", 2)) == ["a", "b"]
    tell("too late")
    rung = Stage("rung 1")
    assert said == [Stage("reading"), Stage("weighing", 0, 2, rung), Stage("weighing", 1, 2, rung)]
    assert said[-1].line == (rung, said[-1])


def test_a_listener_can_end_the_work_and_listening_ends_with_it():
    worked = []

    def ear(stage):
        if stage.done == 2:
            raise Stopped

    with pytest.raises(Stopped), heard(ear):
        for item in steps(range(5), "counting"):
            worked += [item]
    assert worked == [0, 1]
    tell("counting", 2, 5)


def test_what_is_said_during_a_step_is_part_of_it_also_after_a_loop_that_ended_early():
    said = []
    with heard(said.append):
        for item in steps("abc", "records"):
            tell(item)
            if item == "b":
                break
        tell("after")
    assert [(s.what, s.within) for s in said if s.what in ("a", "b", "after")] == [
        ("a", Stage("records", 0, 3)),
        ("b", Stage("records", 1, 3)),
        ("after", None),
    ]
