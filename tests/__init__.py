"""The tests, in folders of the same names as the rooms they test. Helpers that several of them share live in `tests.support`."""
