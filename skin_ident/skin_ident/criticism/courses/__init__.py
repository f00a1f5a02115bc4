"""What belongs to one session alone: zeros, slopes, delays and depths that changed before or during it, and what they must predict."""
