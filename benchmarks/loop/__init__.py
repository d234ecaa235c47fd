"""A robot program in the loop: a cell of MuJoCo, the pipeline and `examples/insert.py`."""
