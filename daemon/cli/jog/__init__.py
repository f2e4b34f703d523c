"""`longreach jog`: drive by hand with a keyboard: what keys mean, how a terminal tells them, the command."""
