// Compiles nothing: the library of this file has the headers that all test programs precompile.
