"""Extended Kalman filter on the peg's three angles and their rates."""
