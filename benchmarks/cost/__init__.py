"""What mechanics, steps and pipeline cost, and whether they last."""
