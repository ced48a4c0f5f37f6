# Writes gltf-psplit.1 from the command's own help:
#
#   cmake -D COMMAND=FILE -D VERSION=TEXT -D PAGE=FILE -P man_page.cmake

# A page does not depend on the terminal.
set(ENV{COLUMNS} 80)

function(help_of words text)
  execute_process(COMMAND ${COMMAND} ${words} --help OUTPUT_VARIABLE said RESULT_VARIABLE result)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${COMMAND} ${words} --help exits with ${result}")
  endif()
  set(${text} "${said}" PARENT_SCOPE)
endfunction()

# Escapes text for troff, so that nothing in it is taken for a command.
function(escape text result)
  string(REPLACE "\\" "\\e" text "${text}")
  string(REPLACE "-" "\\-" text "${text}")
  string(REPLACE "\"" "\\(dq" text "${text}")
  string(REGEX REPLACE "^([.'])" "\\\\&\\1" text "${text}")
  set(${result} "${text}" PARENT_SCOPE)
endfunction()

# Converts help to troff. "  NAME  words" becomes a tagged paragraph, whose words may continue in deeper lines; "Heading:"
# becomes a heading.
function(as_troff help result)
  string(REPLACE ";" "@semicolon@" help "${help}")
  string(REPLACE "[" "@open@" help "${help}")
  string(REPLACE "]" "@close@" help "${help}")
  string(REPLACE "\n" ";" lines "${help}")
  set(page "")
  foreach(line IN LISTS lines)
    string(REPLACE "@semicolon@" ";" line "${line}")
    string(REPLACE "@open@" "[" line "${line}")
    string(REPLACE "@close@" "]" line "${line}")
    if(line MATCHES "^  ([^ ](.*[^ ])?)  +([^ ].*)$")
      set(words "${CMAKE_MATCH_3}")
      escape("${CMAKE_MATCH_1}" name)
      escape("${words}" words)
      string(APPEND page ".TP\n.B \"${name}\"\n${words}\n")
    elseif(line MATCHES "^  ([^ ].*)$")
      escape("${CMAKE_MATCH_1}" name)
      string(APPEND page ".TP\n.B \"${name}\"\n")
    elseif(line MATCHES "^Usage: *(.*)$")
      escape("${CMAKE_MATCH_1}" usage)
      string(APPEND page ".PP\n.B \"${usage}\"\n")
    elseif(line MATCHES "^([A-Z][A-Za-z ]*):$")
      string(APPEND page ".SS ${CMAKE_MATCH_1}\n")
    elseif(line STREQUAL "")
      string(APPEND page ".PP\n")
    else()
      string(STRIP "${line}" line)
      escape("${line}" line)
      string(APPEND page "${line}\n")
    endif()
  endforeach()
  # Removes paragraphs without words.
  string(REGEX REPLACE "(\\.PP\n)+(\\.SS|\\.PP|$)" "\\2" page "${page}")
  set(${result} "${page}" PARENT_SCOPE)
endfunction()

help_of("" help)
# The sentence at the front, which may take several lines.
string(REGEX MATCH "^[^\n]+(\n[^\n]+)*" summary "${help}")
string(REPLACE "\n" " " summary "${summary}")
escape("${summary}" summary)
as_troff("${help}" description)
set(page ".TH GLTF\\-PSPLIT 1 \"\" \"psplit ${VERSION}\" \"User Commands\"
.SH NAME
gltf\\-psplit \\- ${summary}
.SH DESCRIPTION
${description}")

# The subcommands that a help lists; empty if it lists none.
function(verbs_of help result)
  set(verbs "")
  if(help MATCHES "\nSubcommands:\n")
    string(REGEX REPLACE "^.*\nSubcommands:\n" "" verbs "${help}")
    string(REGEX REPLACE "\n\n.*" "" verbs "${verbs}")
    string(REGEX MATCHALL "(^|\n)  [a-z]+" verbs "${verbs}")
    string(REGEX REPLACE "[ \n]" "" verbs "${verbs}")
  endif()
  set(${result} "${verbs}" PARENT_SCOPE)
endfunction()

# Appends a section for a subcommand, which may be a list of words, and sections for its own subcommands.
function(append_section words)
  help_of("${words}" help)
  verbs_of("${help}" verbs)
  # Text that all commands have in common appears once.
  string(REGEX REPLACE "\nExit codes:.*" "\n" help "${help}")
  as_troff("${help}" text)
  string(REPLACE ";" " " name "${words}")
  string(APPEND page ".SH \"GLTF\\-PSPLIT ${name}\"\n${text}")
  foreach(verb IN LISTS verbs)
    append_section("${words};${verb}")
  endforeach()
  set(page "${page}" PARENT_SCOPE)
endfunction()

verbs_of("${help}" verbs)
if(NOT verbs)
  message(FATAL_ERROR "${COMMAND} --help lists no subcommands")
endif()
foreach(verb IN LISTS verbs)
  append_section("${verb}")
endforeach()
file(WRITE ${PAGE} "${page}")
