"""Whether names are as often right as is said: all of them, and by what else is said of their log."""
