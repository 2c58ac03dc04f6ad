# Two stages: the first has compilers and pip's caches, the second only the virtual environment and a user without rights.
# The image was not built here; tests/service/test_compose.py checks what can be checked without Docker.
FROM python:3.11-slim-bookworm AS build
ENV PIP_NO_CACHE_DIR=1 PIP_DISABLE_PIP_VERSION_CHECK=1
RUN python -m venv /venv
ENV PATH=/venv/bin:$PATH
WORKDIR /src
COPY constraints.txt requirements.lock ./
COPY deploy/prune.py deploy/
# torch's CPU build; https://pypi.org/simple has the CUDA build (several GB), which needs its nvidia packages, too.
ARG TORCH_INDEX=https://download.pytorch.org/whl/cpu
RUN pip install --no-deps -c constraints.txt --index-url "$TORCH_INDEX" torch
# Parts of wheels that may not be passed on go in the same layer.
RUN pip install --require-hashes --no-deps -r requirements.lock && python deploy/prune.py
COPY . .
RUN pip install --no-deps .

FROM python:3.11-slim-bookworm
# What the open3d wheel expects of the system (`garmentq doctor` names what is missing).
RUN apt-get update \
    && apt-get install -y --no-install-recommends libegl1 libgl1 libx11-6 libudev1 libidn2-0 \
    && rm -rf /var/lib/apt/lists/* \
    && useradd --uid 10001 --create-home garmentq \
    && install -d -o garmentq -g garmentq -m 0700 /data
COPY --from=build /venv /venv
ENV PATH=/venv/bin:$PATH
# Into the package's folder, from which everybody reads. Another processor than this one's compiles once into the home.
RUN garmentq doctor --warm
ENV PYTHONUNBUFFERED=1 \
    GARMENTQ_HOME=/data \
    NUMBA_CACHE_DIR=/data/numba
USER 10001:10001
WORKDIR /data
ENTRYPOINT ["garmentq"]
CMD ["doctor"]
