"""What the paper's printed figures say about each other: the numbers behind docs/paper.md and its notebook."""
