"""The command `peg-on-hole`: one module for each subcommand, imported when it runs."""
