"""`longreach ui`: a web page on loopback. Its server asks the daemon's socket as the command line does; a browser reaches nothing else.

Imports `source`. `static/` is what the browser gets; uPlot there comes from its authors, with its licence.
"""
