"""What each tuned number of the package changes, halved and doubled."""
