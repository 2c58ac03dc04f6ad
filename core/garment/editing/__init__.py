"""Operations of a pattern maker, each a pure function of a `Pattern`: move, reshape, divide, cut, join."""
