"""Blind test of the search for missing physics: a truth made by other code, sealed answers, scores with their uncertainty."""
