"""Two servers that are not ours, for tests: `servers.py gradio MESH` and `servers.py openai ANSWERS`.

Each prints the port it listens on and serves until it is ended. `servers.py client PORT` asks the
second one through the official `openai` package and prints what it answered.
"""

import base64
import json
import sys
import tempfile
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer


def gradio_app(mesh):
    """TRELLIS's three steps: a session's folder, an image to a state, the state to a GLB."""
    import gradio as gr

    sessions = set()

    def start_session(request: gr.Request):
        sessions.add(request.session_hash)

    def image_to_3d(
        image, multi, seed, strength, steps, slat_strength, slat_steps, algorithm, request: gr.Request
    ):
        if request.session_hash not in sessions:
            raise gr.Error("no folder of this session")
        with open(image, "rb") as photo:
            if not photo.read(8).startswith(b"\x89PNG"):
                raise gr.Error("not a PNG")
        if (steps, slat_steps, algorithm) != (12, 12, "stochastic"):
            raise gr.Error("other settings than TRELLIS's")
        return {"seed": seed}, "video.mp4"

    def extract_glb(state, simplify, texture_size):
        if not state:
            raise gr.Error("no state")
        with open(mesh, "rb") as source, tempfile.NamedTemporaryFile(
            suffix=".glb", delete=False
        ) as target:
            target.write(source.read())
        return target.name, target.name

    with gr.Blocks() as app:
        state = gr.State()
        image = gr.Image(type="filepath", format="png")
        multi = gr.JSON()
        numbers = [gr.Number() for _ in range(5)]
        algorithm = gr.Textbox()
        video, model, download = gr.Textbox(), gr.Model3D(), gr.File()
        gr.Button().click(start_session, [], [], api_name="start_session")
        gr.Button().click(
            image_to_3d, [image, multi, *numbers, algorithm], [state, video], api_name="image_to_3d"
        )
        gr.Button().click(
            extract_glb, [state, numbers[0], numbers[1]], [model, download], api_name="extract_glb"
        )
    app.queue()
    _, address, _ = app.launch(prevent_thread_lock=True, quiet=True, server_name="127.0.0.1")
    print(address.rstrip("/").rsplit(":", 1)[1], flush=True)
    threading.Event().wait()


class Chat(BaseHTTPRequestHandler):
    """Chat completions: answers by the name of the schema, after looking at the pictures."""

    answers = {}

    def log_message(self, *_):
        pass

    def do_POST(self):
        body = json.loads(self.rfile.read(int(self.headers["content-length"])))
        schema = body["response_format"]["json_schema"]
        pictures = 0
        for message in body["messages"]:
            for piece in message["content"] if isinstance(message["content"], list) else []:
                if piece["type"] == "image_url":
                    head, data = piece["image_url"]["url"].split(",", 1)
                    assert head == "data:image/png;base64", head
                    assert base64.b64decode(data, validate=True).startswith(b"\x89PNG")
                    pictures += 1
        assert schema["strict"] and schema["schema"]["additionalProperties"] is False
        assert pictures >= 8, "eight views, and the photo with the first question"
        answer = self.answers[schema["name"]]
        reply = {
            "id": "chatcmpl-1",
            "object": "chat.completion",
            "created": 1,
            "model": body["model"],
            "choices": [
                {
                    "index": 0,
                    "finish_reason": "stop",
                    "message": {"role": "assistant", "content": json.dumps(answer)},
                }
            ],
            "usage": {"prompt_tokens": 3, "completion_tokens": 5, "total_tokens": 8},
        }
        body = json.dumps(reply).encode()
        self.send_response(200)
        self.send_header("content-type", "application/json")
        self.send_header("content-length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)


def chat_server(answers):
    with open(answers) as source:
        Chat.answers = json.load(source)
    server = ThreadingHTTPServer(("127.0.0.1", 0), Chat)
    print(server.server_port, flush=True)
    server.serve_forever()


def client(port, bodies):
    """Sends what kinfold sent through the official client: the same words on the wire, by it."""
    import openai

    speaker = openai.OpenAI(base_url=f"http://127.0.0.1:{port}/v1", api_key="unused")
    with open(bodies) as source:
        for body in json.load(source):
            reply = speaker.chat.completions.create(**body)
            choice = reply.choices[0]
            print(json.dumps([choice.finish_reason, json.loads(choice.message.content)]))


if __name__ == "__main__":
    what, *rest = sys.argv[1:]
    {"gradio": gradio_app, "openai": chat_server, "client": client}[what](*rest)
