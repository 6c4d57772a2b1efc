"""The rules as compiled functions over arrays: numpy and numba only, no frameworks, no validation.

A *rule* is scalars in, scalars out, and cites its clause. A *phase* is one block: the loop over its lanes. A *batch*
walks the blocks.
"""
