"""Coupon tests of fabrics: how a scene of one is built, and its closed forms."""
