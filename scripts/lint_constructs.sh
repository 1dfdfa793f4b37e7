#!/bin/sh
# VHDL that some tool does not take (docs/guide/vendor.md says which): refused in rtl/, comments aside.
set -eu
cd "$(dirname "$0")/../rtl"

avoided='\<abs\>|\<(minimum|maximum)\>
\?[=/<>]|\?\?|\<(case|select)\?
(<=|:=|\(|when|if) *\<(and|or|nand|nor|xor|xnor) 
<<|\<(force|release|protected|shared|context|file)\>
\<package +\w+ +is +new\>|^ *generic *\( *(type|package|function|procedure)\>
\<(fixed|float)_pkg\>|\<textio\>|\<wait\>|\<after\>
\\'
deferred='^ *constant +[^=]*;'

# A statement at a time: conditional and selected assignments within a process or a subprogram.
sequential='
BEGIN { RS = ";"; line = 1 }
{
    lines = split($0, parts, "\n")
    statement = " " tolower($0) " "
    gsub(/[^a-z0-9_<:=]+/, " ", statement)
    if (statement ~ / end (process|procedure) /) within = 0
    else if (statement ~ / (process|procedure) /) within = 1
    if (statement ~ /:=.* when .* else / || within && statement ~ /<=.* when .* else / ||
        within && statement ~ / with .* select .*[:<]=/) {
        at = 1
        while (at < lines && tolower(parts[at]) !~ /[^a-z_](when|select)[^a-z_]/) at++
        print line + at - 1 ":" parts[at]
    }
    line += lines - 1
}'

status=0
while read -r file; do
    found=$(sed "s/--.*//" "$file" | { grep -nEi -e "$avoided" -e "$deferred" || :; }; sed "s/--.*//" "$file" | awk "$sequential")
    [ -n "$found" ] || continue
    echo "$found" | sed "s|^|rtl/$file:|; s|\$|    <- see docs/guide/vendor.md|" >&2
    status=1
done <sources.f
exit $status
