# Tests of this part; owned by it.
