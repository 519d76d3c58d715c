# What Doxygen reads of a header: its first comment is the file's, and < in comments is no HTML (but of ///<).
1s|^///|/// \\file\n///|
:more
s|\(///.*[^\\/]/\{0,1\}\)<|\1\\<|
t more
