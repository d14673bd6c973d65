"""What a page says of the run: verdict, accuracy, checks, inputs, meshes.

One section a module.
In: results. Out: blocks.
"""
