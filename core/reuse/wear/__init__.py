"""A recovered garment worn again: on another body, made to measure, with what it needs of a stored result."""
