"""Many bags: which, who replays them, what is done already, and one table and page of them all."""
