"""What a fabric is: its laws of tension and shear, its card with sources, the library."""
