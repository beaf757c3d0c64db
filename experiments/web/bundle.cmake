# cmake -D FILES="a.html;b.js" -D FOLDER=... -D OUTPUT=... -P bundle.cmake: the page's files as a C++ source.
set(types_html "text/html; charset=utf-8")
set(types_css "text/css; charset=utf-8")
set(types_js "text/javascript; charset=utf-8")
set(types_svg "image/svg+xml")

set(arrays)
set(entries)
set(number 0)
foreach(file IN LISTS FILES)
    file(READ ${FOLDER}/${file} octets HEX)
    string(REGEX REPLACE "([0-9a-f][0-9a-f])" "'\\\\x\\1'," octets "${octets}")
    cmake_path(GET file EXTENSION LAST_ONLY extension)
    string(SUBSTRING ${extension} 1 -1 extension)
    string(APPEND arrays "constexpr char file_${number}[] = {${octets}};\n")
    string(APPEND entries "    {\"/${file}\", \"${types_${extension}}\", {file_${number}, sizeof file_${number}}},\n")
    math(EXPR number "${number} + 1")
endforeach()
file(WRITE ${OUTPUT} "// Made by bundle.cmake.
#include \"experiments/web/page_files.h\"

namespace romano::experiments {
namespace {

${arrays}
constexpr PageFile files[] = {
${entries}};

}  // namespace

std::span<const PageFile> page_files() {
    return files;
}

}  // namespace romano::experiments
")
