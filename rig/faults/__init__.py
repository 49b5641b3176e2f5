"""What becomes of a rig when something breaks: campaigns of faults, judged by the plant's truth.

A `kinds.FaultKind` says what may break and what must come of it, a `case.Case` is one of them at a
drawn place and moment, `stage` makes it happen, `oracle` judges it by what is true of the plant,
and `campaign` runs many and sums them up.
"""
