#!/bin/sh
# VHDL that some synthesizer does not take (docs/vendor.md says which): refused in rtl/, comments aside.
# registers/ is written by PeakRDL and left alone.
set -eu
cd "$(dirname "$0")/../rtl"

avoided='\<abs\>|\<(minimum|maximum)\>
\?[=/<>]|\?\?|\<(case|select)\?
(<=|:=|\(|when|if) *\<(and|or|nand|nor|xor|xnor) 
<<|\<(force|release|protected|shared|context|file)\>
\<package +\w+ +is +new\>|^ *generic *\( *(type|package|function|procedure)\>
\<(fixed|float)_pkg\>|\<textio\>|\<wait\>|\<after\>'
deferred='^ *constant +[^=]*;'

status=0
for file in $(grep -v '^registers/' sources.f); do
    found=$(sed 's/--.*//' "$file" | grep -nEi -e "$avoided" -e "$deferred") || continue
    echo "$found" | sed "s|^|rtl/$file:|; s|\$|    <- see docs/vendor.md|" >&2
    status=1
done
exit $status
