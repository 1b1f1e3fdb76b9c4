# SPDX-License-Identifier: Apache-2.0
# Covis in a container: its Debian packages are built in one stage and installed in another (docs/installation.md).
#   docker build -t covis .
#   docker run --rm -v "$PWD:/data" covis run /data/video.mp4 --out /data/result
FROM debian:12 AS build
WORKDIR /covis
COPY tools/setup tools/setup
RUN tools/setup --packages
COPY . .
RUN cmake --preset demo -DCOVIS_PYTHON=ON
RUN cmake --build build/demo
RUN cd build/demo && cpack -B /packages

FROM debian:12
COPY --from=build /packages/*.deb /packages/
RUN apt-get update && apt-get install -y --no-install-recommends /packages/*.deb && rm -rf /packages /var/lib/apt/lists/*
WORKDIR /data
ENTRYPOINT ["covis"]
