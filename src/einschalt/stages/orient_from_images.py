"""PLACEHOLDER so that the package imports; helper A overwrites this file."""


def orient_from_images(image_pairs, principal_distance, **_options):
    raise NotImplementedError
