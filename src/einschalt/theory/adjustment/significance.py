"""Levels of significance, each by what it decides; nothing is imported.

A level is the probability of a false alarm where nothing is wrong. Tests of single
measurements are made by the thousand, and a good measurement that is taken out costs
precision: they are strict. Tests of a whole block are few, and what they look for
stands out of the noise by little: they may be wrong once in a hundred blocks.
"""

GROSS_ERROR_SIGNIFICANCE = 0.001
"""Of a model, or a point, without gross errors: that it has a suspect.

The level of Baarda's data snooping (1968), held for all tests of a model together."""

FINDING_SIGNIFICANCE = 0.001
"""Of a block in which nothing is wrong: that a finding is reported all the same.

What is reported must exceed what chance does in one block of a thousand."""

SYSTEMATIC_SIGNIFICANCE = 0.01
"""Of a block without systematic errors: that a common pattern is found in it.

One block in a hundred: a strain of 5 cm stands out of the noise by little more."""

CLAIM_SIGNIFICANCE = 0.01
"""Of a block whose errors are as the stated precision has them: that it is rejected.

Held for all tests of the stated precision together."""

OWN_DEFORMATION_SIGNIFICANCE = 0.01
"""Of a block whose models have no deformations of their own: that some are found.

What is found enlarges standard errors by what it is: a false alarm costs little."""

MIN_REPORTED_RATIO = 1.25
"""A root mean square this much beyond the expected one is worth a word."""
