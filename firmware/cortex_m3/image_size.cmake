# image_size(IMAGE STACK FLASH RAM): an image's octets of flash (text, data) and of RAM (data, bss),
# without those of its stack. SIZE is arm-none-eabi-size.
function(image_size image stack flash ram)
    execute_process(COMMAND ${SIZE} ${image} OUTPUT_VARIABLE report COMMAND_ERROR_IS_FATAL ANY)
    string(REGEX MATCH "\n *([0-9]+)[ \t]+([0-9]+)[ \t]+([0-9]+)" line "${report}")
    math(EXPR flash_octets "${CMAKE_MATCH_1} + ${CMAKE_MATCH_2}")
    math(EXPR ram_octets "${CMAKE_MATCH_2} + ${CMAKE_MATCH_3} - ${stack}")
    set(${flash} ${flash_octets} PARENT_SCOPE)
    set(${ram} ${ram_octets} PARENT_SCOPE)
endfunction()
