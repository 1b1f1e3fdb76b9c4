# SPDX-License-Identifier: Apache-2.0
# The viewer's page: web/ with three.js, bundled into one script that the command holds. npm installs exactly what
# web/package-lock.json names, and runs no script of a package.
if(NOT COVIS_NPM)
  message(FATAL_ERROR "COVIS_VIEWER is ON, and npm is missing, which bundles the viewer's page: install npm, or configure "
    "with -DCOVIS_VIEWER=OFF")
endif()
find_package(Boost 1.74 REQUIRED)

set(web ${PROJECT_SOURCE_DIR}/web)
set(bundle ${PROJECT_BINARY_DIR}/web)
set(packages ${bundle}/node_modules/.package-lock.json)
add_custom_command(OUTPUT ${packages}
  COMMAND ${CMAKE_COMMAND} -E copy ${web}/package.json ${web}/package-lock.json ${web}/.npmrc ${bundle}
  COMMAND ${COVIS_NPM} ci --prefix ${bundle} --ignore-scripts --prefer-offline --no-audit --no-fund --silent
  COMMAND ${CMAKE_COMMAND} -E touch ${packages}
  DEPENDS ${web}/package.json ${web}/package-lock.json
  COMMENT "Installing the packages of the viewer's page" VERBATIM)
file(GLOB web_sources CONFIGURE_DEPENDS ${web}/src/*.js ${web}/src/*.css ${web}/src/*.html)
set(page ${bundle}/page)
set(page_files ${page}/index.html ${page}/viewer.js ${page}/viewer.css)
add_custom_command(OUTPUT ${page_files}
  COMMAND ${CMAKE_COMMAND} -E env NODE_PATH=${bundle}/node_modules ${bundle}/node_modules/.bin/esbuild
    ${web}/src/viewer.js --bundle --format=iife --minify --charset=utf8 --legal-comments=inline --log-level=warning --outfile=${page}/viewer.js
  COMMAND ${CMAKE_COMMAND} -E copy ${web}/src/index.html ${web}/src/viewer.css ${page}
  DEPENDS ${packages} ${web_sources}
  COMMENT "Bundling the viewer's page" VERBATIM)
add_custom_target(covis_page DEPENDS ${page_files})
add_dependencies(covis_view covis_page)
set_source_files_properties(view/page.cpp PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON
  OBJECT_DEPENDS "${page_files}" COMPILE_DEFINITIONS "COVIS_PAGE_FOLDER=\"${page}\"")
