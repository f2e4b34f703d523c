"""Where model and measurement disagree, and the name of what is missing.

`find` is the whole way through the rooms, `loop` and `study` go it many times; `watch` goes another. Rooms, each importing only from those
before it:

- data: a log as it is: its channels and their faults, noise, windows
- balance: equations formed from measurements alone, and what makes them uneven
- fitting: the model on windows of a log: simulation, start states, cost, sensitivities, least squares
- signatures: what each candidate would change in the residuals, with the constants projected out
- evidence: one score for effects and constants together, names with their probabilities
- search: trials, acceptance, verdict, smallest visible sizes
- maneuvers: which move or sensor would separate explanations
- outcome: where the gap is, what was found, the improved rig file
- remainder: what is left without a name, and how it can be kept
- report: pictures and page
- watch: numbers that wear and faults change, over the logs of weeks
"""
