"""What estimators cost and how well they do: motions, runs over them, a chart and a map."""
