"""Scripts and their parts that published figures come from."""
