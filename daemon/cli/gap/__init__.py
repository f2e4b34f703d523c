"""Commands of the gap: find, next, loop, study, watch, demo."""
