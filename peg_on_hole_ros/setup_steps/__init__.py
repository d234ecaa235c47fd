"""Setting up a cell: what is asked, what a recording tells, and how each setting is known."""
