"""A muscle on a joint: torque and angle become force and shape, by a geometry that is reckoned by hand."""

import math

import numpy as np
import pytest
from corpus import PRESSURE, ROWS, TIME, as_text
from typer.testing import CliRunner

from pam_ident.core import DataError
from pam_ident.fitting.fit import fit_long
from pam_ident.model import Model
from pam_ident.records import read_record
from pam_ident.records.joint_lever import JointLever
from pam_ident.records.long import open_long

HEADERS = ("time_s", "pressure_MPa", "Torque", "Knee")
POINTS = "[lever]\ntorque_Nm = 'Torque'\nangle_deg = 'Knee'\na_mm = 120\nb_mm = 160\nangle_offset_deg = 90\n"
PULLEY = "[lever]\ntorque_Nm = 'Torque'\nangle_deg = 'Knee'\nradius_mm = 30\n"
ANGLE = np.tile(np.linspace(0.0, -20.0, ROWS // 2), 2)
TORQUE = np.linspace(96.0, 60.0, ROWS)


def joint(headers=HEADERS, torque=TORQUE, angle=ANGLE):
    return as_text(headers, np.column_stack([TIME, PRESSURE, torque, angle]))


def test_two_points_and_the_axis_are_a_triangle():
    """Sides 120 and 160 at a right angle: 200 mm, arm 96 mm. At 60° between equal sides all three are equal."""
    lever = JointLever(a_mm=120.0, b_mm=160.0, angle_offset_deg=90.0)
    assert lever.span(np.zeros(1)) == pytest.approx(200.0) and lever.arm(np.zeros(1)) == pytest.approx(96.0)
    even = JointLever(a_mm=70.0, b_mm=70.0)
    assert even.span(np.array([math.pi / 3.0])) == pytest.approx(70.0)
    assert even.arm(np.array([math.pi / 3.0])) == pytest.approx(70.0 * math.sqrt(3.0) / 2.0)


def test_the_work_of_the_torque_is_that_of_the_force():
    """T dφ = F dL along the way, by differences."""
    lever, angle = JointLever(a_mm=250.0, b_mm=45.0, angle_offset_deg=35.0, fixed_mm=20.0), np.linspace(0.2, 1.4, 4001)
    made = lever.converted(1000.0 + 300.0 * np.sin(angle), angle)
    torque = 1000.0 + 300.0 * np.sin(angle)
    np.testing.assert_allclose(
        made["force"][1:-1] * np.gradient(made["length"])[1:-1], torque[1:-1] * (angle[1] - angle[0]), rtol=1e-6
    )


def test_a_record_of_torque_and_angle_is_read_as_force_and_length(put):
    record = read_record(put(joint(), mapping=POINTS))
    span = np.sqrt(120.0**2 + 160.0**2 - 2.0 * 120.0 * 160.0 * np.cos(np.radians(90.0 + ANGLE)))
    np.testing.assert_allclose(200.0 * (1.0 - record.inputs.contraction), span, atol=1e-3)
    assert record.force[0] == pytest.approx(1000.0) and record.inputs.contraction[0] == pytest.approx(0.0, abs=1e-12)
    np.testing.assert_allclose(
        record.force, 1000.0 * TORQUE * span / (120 * 160 * np.cos(np.radians(ANGLE))), rtol=1e-4
    )
    (note,) = record.notes
    assert note.code == "lever" and "√(120² + 160² − 2·120·160 cos (angle + 90°)) mm" in note.text
    assert record.columns["force"] == "Torque and Knee by [lever]" and record.columns["torque"] == "Torque"


def test_a_pulley_winds_up_its_radius_times_the_angle(put):
    """30 mm and 0.1 rad: 3 mm; 30 N·m: 1000 N. A factor turns the sign of an angle."""
    mapping = PULLEY.replace("'Knee'", "{ column = 'Knee', factor = -1 }") + "angle_offset_deg = 2\n"
    record = read_record(put(joint(torque=np.full(ROWS, 30.0)), mapping=mapping))
    np.testing.assert_allclose(record.force, 1000.0)
    np.testing.assert_allclose(record.inputs.displacement_mm, 30.0 * np.radians(2.0 - ANGLE), atol=1e-4)


def test_other_units_and_columns_that_are_named_beside(put):
    plain = read_record(put(joint(), mapping=POINTS))
    text = joint(("t", "p", "Torque [Nmm]", "Knee [rad]"), 1000.0 * TORQUE, np.radians(ANGLE))
    units = POINTS.replace("torque_Nm = 'Torque'", "torque_Nmm = 3").replace("angle_deg = 'Knee'", "angle_rad = 4")
    other = read_record(put(text, "other.csv", units + "[columns]\ntime_s = 't'\npressure_MPa = 'p'\n"))
    np.testing.assert_allclose(other.force, plain.force, rtol=1e-4)
    np.testing.assert_allclose(other.inputs.contraction, plain.inputs.contraction, atol=1e-4)


def test_inspect_states_the_conversion_and_a_fit_in_chunks_reads_the_same(put):
    from pam_ident.cli import app

    path = put(joint(), mapping=PULLEY)
    shown = CliRunner().invoke(app, ["inspect", str(path)]).stdout
    assert "by the lever: force = torque/30 mm, displacement = 30 mm · (angle + 0°)" in shown
    record = read_record(path)
    with open_long(path) as on_disk:
        sample = on_disk.sample(ROWS)
        np.testing.assert_allclose(sample.force, record.force)
        found = fit_long(Model.build("chou_hannaford", ("force_bias",)), on_disk, "together")
    assert found.n == ROWS


@pytest.mark.parametrize(
    ("mapping", "words"),
    [
        (PULLEY + "a_mm = 3\n", ["[lever] expected", "radius_mm, or a_mm and b_mm"]),
        (POINTS.replace("b_mm = 160\n", ""), ["[lever] expected"]),
        (POINTS.replace("b_mm = 160", "b_mm = 0"), ["not above 0 mm"]),
        (POINTS.replace("b_mm = 160", "b_mm = '160'"), ["not b_mm = '160'"]),
        (POINTS.replace("angle_deg", "angle_grad"), ["not angle_grad"]),
        (POINTS.replace("torque_Nm = 'Torque'\n", ""), ["[lever] expected"]),
        (POINTS.replace("'Torque'", "'Moment'"), ["no column 'Moment'", "torque_Nm"]),
        (POINTS + "[columns]\ntime_s = 1\npressure_MPa = 2\nforce_N = 3\n", ["force is given by [columns] and by"]),
        (POINTS + "[columns]\ntime_s = 1\n", ["no pressure column"]),
        ("lever = 3\n", ["[lever] expected"]),
    ],
)
def test_a_lever_that_cannot_be_is_refused(put, mapping, words):
    path = put(joint(), mapping=mapping)
    with pytest.raises(DataError) as refused:
        read_record(path)
    assert all(word in str(refused.value) for word in words), refused.value


def test_a_unit_against_the_header_and_an_arm_through_the_axis_are_refused(put):
    with pytest.raises(DataError, match=r"torque_Nm, but the column's header is 'Torque \[Nmm\]'"):
        read_record(put(joint((*HEADERS[:2], "Torque [Nmm]", "Knee")), mapping=POINTS.replace("'Torque'", "3")))
    with pytest.raises(DataError, match=r"row 7, column 'Knee'.*arm is .* mm there"):
        angle = ANGLE.copy()
        angle[5] = 90.0
        read_record(put(joint(angle=angle), mapping=POINTS))
