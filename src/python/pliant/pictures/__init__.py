"""Pictures, movies and plots of results: the commands `pliant render` and `pliant plot`.

`start.py` starts them. They need more packages than `import pliant` does; nothing here is imported by it.
"""
