"""Work shared out among processes, or the machines of a cluster."""
