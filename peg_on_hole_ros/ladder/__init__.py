"""Models of one peg from a closed form to the full equations, and the choice among them."""
