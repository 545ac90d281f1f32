# An image with MLIC installed from its Debian package.
#   docker build -t mlic .
#   docker run --rm -v "$PWD:/data" mlic rosrun mlic calibrate --rig /data/rig.yaml --bag /data/drive.bag --output /data/result
FROM debian:bookworm AS build
COPY . /mlic
RUN /mlic/scripts/make_deb.sh /packages

FROM debian:bookworm
COPY --from=build /packages /packages
RUN apt-get update && apt-get install -y --no-install-recommends /packages/*.deb && rm -rf /packages /var/lib/apt/lists/*
CMD ["rosrun", "mlic", "calibrate", "--help"]
