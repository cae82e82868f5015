# docker build -t vcmm .        docker run --rm -v "$PWD:/work" vcmm uncertainty plate.toml --out result
FROM python:3.12-slim AS build
WORKDIR /source
COPY . .
RUN pip install --no-cache-dir build && python -m build --wheel --outdir /wheel

FROM python:3.12-slim
# --build-arg EXTRAS="[view]" adds pyvista, which draws without a display by EGL
ARG EXTRAS=""
RUN if [ -n "$EXTRAS" ]; then apt-get update && apt-get install -y --no-install-recommends libegl1 libgl1 libgl1-mesa-dri libxrender1 \
    && rm -rf /var/lib/apt/lists/*; fi
COPY --from=build /wheel /wheel
RUN pip install --no-cache-dir "$(ls /wheel/*.whl)${EXTRAS}" && rm -rf /wheel && useradd --create-home vcmm
USER vcmm
WORKDIR /work
ENV OPENBLAS_NUM_THREADS=1
ENTRYPOINT ["vcmm"]
CMD ["--help"]
