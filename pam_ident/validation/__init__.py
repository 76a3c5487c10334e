"""Whether the program is right: sealed challenges and their scores, certified problems, what an effect promises."""
