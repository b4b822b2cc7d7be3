"""What a block is compiled to: chains of its tearing, in floats, on arrays and on intervals."""
