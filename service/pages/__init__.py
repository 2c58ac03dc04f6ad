"""The pages: what people look at in a browser, over the same routes that programs use."""
