// Tests write and read bytes: files that are opened without a mode are no text here, either. MinGW's start of a
// program takes this in place of its own, which says text.
#include <fcntl.h>

#undef _fmode
extern "C" int _fmode;
int _fmode = _O_BINARY;
