"""What can be set: the table, its checks, and the files that it is read from."""
