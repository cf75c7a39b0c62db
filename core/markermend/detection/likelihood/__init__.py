"""Stages of the likelihood-ratio detector: every stage is a pure function of arrays.

::

    findings     long takes in overlapping windows; candidates become findings with evidence
    window       the order of the stages on one window
    swaps        two markers that exchange their places
    filling      a dense working copy of a take with gaps
    neighbours   which markers keep their distances to which
    frames       local frames of reference, by closed-form rotations
    prediction   each marker from its neighbours, no frame ever predicting itself
    whitening    noise spectra and the filters that whiten
    templates    exact likelihood ratios of boxes and triangles from cumulative sums
    scales       robust local scales
    sharp        heavy noise, and what the stages for sudden artefacts share
    peaks        boxes of 1 to 3 frames
    steps        pairs of opposite jumps
    nullscale    how large a score usually is, learnt from the take
    slow         triangles, and what a stronger one on a neighbour explains
    calibration  from a statistic to the probability that a finding is real
    reach        the smallest slow change that would be seen
    star         the model-free check
"""
