"""Who is near whom; imports no kernel of its own, so that a case is checked without a compiler."""
