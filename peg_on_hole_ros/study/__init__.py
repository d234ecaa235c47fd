"""What methods cost and how well they do: integrators, problems, maps of failure, scores."""
