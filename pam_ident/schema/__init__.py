"""Everything that is written as JSON for other programs, with the versions of its schemas."""
