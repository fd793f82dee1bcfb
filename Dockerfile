# Does the two commands of the README on a bare Debian 12, with all systems.
#   docker build -t rangegrasp .                     # both: builds the program, runs a trial, builds and runs all tests
#   docker build --target program -t rangegrasp .    # the program alone
#   docker run --rm -v "$PWD/results:/opt/rangegrasp/results" rangegrasp run experiments/laser_single.yaml
FROM debian:12 AS program
WORKDIR /opt/rangegrasp
COPY . .
RUN apt-get update && apt-get install -y --no-install-recommends git && scripts/setup all && RANGEGRASP_SYSTEMS=all scripts/build release rangegrasp && \
    scripts/rangegrasp run experiments/laser_single.yaml --objects salt_cylinder --trials 1 && rm -rf results /var/lib/apt/lists/*
ENTRYPOINT ["scripts/rangegrasp"]
CMD ["--help"]

FROM program AS tests
RUN scripts/test && rm -rf /var/lib/apt/lists/*
