"""The pages for browsers, over the same routes that programs use."""
