"""Many muscles at once: a table and a page, resumed where it stopped."""
