"""The page of ``einschalt serve``, on this computer alone: for people who do not type.

Only the command imports it; its framework comes with the extra ``serve``.
"""
