"""Stages of the likelihood-ratio detector: every stage is a pure function of arrays.

::

    windows      long takes in overlapping windows, so that time and memory stay linear
    filling      a dense working copy of a take with gaps
    neighbours   which markers keep their distances to which
    frames       local frames of reference, by closed-form rotations
    prediction   each marker from its neighbours, no frame ever predicting itself
    whitening    noise spectra and the filters that whiten
    templates    exact likelihood ratios of boxes and triangles from cumulative sums
    sharp        peaks and heavy noise
    steps        pairs of opposite jumps; swaps
    slow         triangles under a learnt null scale
    echoes       what a stronger finding on a neighbour explains
    calibration  from a statistic to the probability that a finding is real
    reach        the smallest slow change that would be seen
    star         the model-free check
"""
