"""What acts: closed forms and sums over the neighbors of one particle."""
